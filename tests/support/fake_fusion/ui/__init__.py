"""User interface: commands, inputs, dialogs, toolbars, graphics."""

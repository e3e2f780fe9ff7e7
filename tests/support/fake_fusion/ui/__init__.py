"""The user interface: commands, inputs, dialogs, toolbars, graphics."""

"""Hardware in the loop: wire protocol, links, devices, emulated robots and sessions."""

"""Links to hardware: UDP and serial lines."""

"""Writers for the files of a robot folder, and their atomic replacement."""

"""Writers of robot files, a module or a folder a format."""

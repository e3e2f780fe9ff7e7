"""Bodies of a Fusion design with their mass properties and meshes."""

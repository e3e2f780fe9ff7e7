"""The files of a robot folder, and how they take the place of earlier ones."""

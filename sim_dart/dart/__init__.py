"""DART engine: skeletons, worlds and contacts.

Functions import `dartpy` late, since the import takes 0.2 s and most runs do not need it.
"""

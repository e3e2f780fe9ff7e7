"""DART: skeletons, worlds, contacts.

Functions import `dartpy` where they use it: it takes a fifth of a second, and most runs do without.
"""

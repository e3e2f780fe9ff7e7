"""Model of the dialog: the muscle table with its selection and undo, and edits of it."""

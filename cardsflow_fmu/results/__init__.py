"""Results of a run: tables, summaries, the files of a results folder."""

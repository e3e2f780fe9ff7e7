"""Names of the files of a run."""

TABLE = "results.csv"
PARQUET = "results.parquet"
UNITS = "results.units.json"
SUMMARY = "summary.json"
SOLVE_TIMES = "solve_times.csv"
EXPERIMENT = "experiment.zip"
"""The experiment as its FMUs carry it, with the robot's files and its visual meshes."""

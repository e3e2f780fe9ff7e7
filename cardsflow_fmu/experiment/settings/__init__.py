"""Tables of experiment.toml: a model each."""

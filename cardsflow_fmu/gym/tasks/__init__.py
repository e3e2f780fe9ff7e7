"""Tasks of environments: observations, rewards and the start of episodes."""

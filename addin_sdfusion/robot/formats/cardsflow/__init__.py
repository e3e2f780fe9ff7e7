"""The cardsflow.xml format: muscles and end effectors, next to a robot file."""

"""cardsflow.xml: muscles and points next to a robot's file."""

"""cardsflow.xml: muscles and points beside a robot's file."""

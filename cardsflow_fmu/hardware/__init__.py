"""Hardware in the loop: the frames, the links that carry them, devices and what stands for them."""

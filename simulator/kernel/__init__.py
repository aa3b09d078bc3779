"""The compiled part: motion, steps, events and the jump loop, composed for the effects that are on."""

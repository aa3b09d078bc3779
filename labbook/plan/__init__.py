"""The order of the experiments, and the sheet on which they are run."""

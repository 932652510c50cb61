"""What a paper needs and a rig does not: experiments, identification, calibration and their reports."""

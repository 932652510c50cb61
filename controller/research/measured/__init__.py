"""Measured data of others, blind: what Tendril makes of it, beside what needs less."""

"""How server and rig do: health, alarms, figures, and what probes ask for."""

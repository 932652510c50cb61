"""How server and rig do: beat, alarms, figures, and what probes ask for."""

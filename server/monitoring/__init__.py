"""How the server does, for machines that watch over it: /healthz and /metrics."""

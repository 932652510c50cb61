"""FastAPI server: one origin for page, REST, live socket, 3D view and recordings."""

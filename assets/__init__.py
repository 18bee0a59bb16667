"""Models that ship with the project, as package data; `SOURCES.md` says where each comes from and its licence."""

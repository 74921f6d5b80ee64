"""Generates C sources and documents from the schema, firmware/schema/."""

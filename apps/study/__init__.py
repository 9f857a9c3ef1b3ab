"""Studies of burin: a TOML file becomes a plan, Snakemake runs it, a report shows it (docs/studies.md)."""

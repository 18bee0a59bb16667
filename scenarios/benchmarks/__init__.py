"""The project's own benchmarks: what `remote-agent bench` measures, ratios beside the figures."""

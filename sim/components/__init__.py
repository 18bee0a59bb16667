"""The units of the spacecraft, one class each.

A component has `step(dt_s, ...)`, which lets time pass for it, methods named after its telecommands, which return the
reason of a refusal or None, `telemetry()` by channel name, and `set_fault(mode, active, parameters)`, the hook that
`sim.faults` calls. No component knows another: `sim.spacecraft` carries what one needs of the other.
"""

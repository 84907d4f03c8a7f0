# SPDX-License-Identifier: Apache-2.0
"""The page of `servoctl ui`: one thread works on the bus (engine.py), a web server brings it to browsers (server.py)."""

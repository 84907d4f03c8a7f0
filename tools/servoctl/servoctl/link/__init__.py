# SPDX-License-Identifier: Apache-2.0
"""The bus and a node on it: adapters, SDO, borrowed PDOs, streams, and who may speak when."""

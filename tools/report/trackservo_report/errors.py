# SPDX-License-Identifier: Apache-2.0
"""The error that ends the report with one sentence."""


class InputError(Exception):
    """The input cannot be used; the text names the file and the reason."""

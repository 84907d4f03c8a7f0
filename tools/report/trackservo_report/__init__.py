# SPDX-License-Identifier: Apache-2.0
"""The report of the experiments: one offline HTML page and one terminal table from the files of `sim_host`."""

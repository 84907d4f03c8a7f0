# SPDX-License-Identifier: Apache-2.0
"""Results for people and programs: tables, pages, recordings, files."""

/* SPDX-License-Identifier: Apache-2.0 */
/* Given to ESBMC before each source: its own macro for this builtin is no constant expression. */
#undef __builtin_offsetof

// SPDX-License-Identifier: Apache-2.0
// Gives the headers a file to be compiled with (see headers.hpp).

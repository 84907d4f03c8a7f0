// Gives the headers a file to be compiled with (see headers.hpp).

// The emulated board on a CAN bus that clients reach: what a user would flash, before there is a board.
#include <fmt/format.h>

int main() { return 0; }

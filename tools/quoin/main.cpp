/// The commands `quoin` and `quoin-mpi`.

#include "command_line.hpp"

int main(int argc, char** argv) { return quoin::commands::run_command_line(argc, argv); }

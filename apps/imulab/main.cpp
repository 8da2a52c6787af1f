#include "apps/imulab/command.hpp"

int main(int argc, char** argv) { return imulab::command::run({argv + 1, argv + argc}); }

#include <fcntl.h>
#include <unistd.h>

#include "app/app.hpp"

int main(int argc, char** argv) {
  // If one of these is closed, the next file or connection would take its place: it would be typed to, or logged to.
  for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (fcntl(descriptor, F_GETFD) < 0) static_cast<void>(open("/dev/null", O_RDWR));
  }
  return baton::app::run({argv + 1, argv + argc});
}

#include "app/app.hpp"

int main(int argc, char** argv) {
  return baton::app::run({argv + 1, argv + argc});
}

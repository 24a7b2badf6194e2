#include "baton/proving/dice.hpp"

namespace baton {

std::uint64_t mixed_seed(std::uint64_t seed, std::uint64_t stream) {
  const auto mix = [](std::uint64_t x) {  // splitmix64
    x += 0x9e3779b97f4a7c15ULL;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
    return x ^ (x >> 31);
  };
  return mix(mix(seed) + stream);
}

}  // namespace baton

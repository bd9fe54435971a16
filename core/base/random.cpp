#include "core/base/random.h"

namespace camrig {
namespace {

struct Block {
    std::uint32_t word[4];
};

Block philox4x32_10(Block block, std::uint32_t key0, std::uint32_t key1) {
    for (int round = 0; round < 10; ++round) {
        const std::uint64_t product0 = std::uint64_t{0xD2511F53u} * block.word[0];
        const std::uint64_t product1 = std::uint64_t{0xCD9E8D57u} * block.word[2];
        block = Block{
            {static_cast<std::uint32_t>(product1 >> 32) ^ block.word[1] ^ key0, static_cast<std::uint32_t>(product1),
             static_cast<std::uint32_t>(product0 >> 32) ^ block.word[3] ^ key1, static_cast<std::uint32_t>(product0)}};
        key0 += 0x9E3779B9u;
        key1 += 0xBB67AE85u;
    }
    return block;
}

}  // namespace

std::uint64_t random_bits(std::uint64_t seed, std::uint64_t stream, std::uint64_t counter) {
    const auto low = [](std::uint64_t v) { return static_cast<std::uint32_t>(v); };
    const auto high = [](std::uint64_t v) { return static_cast<std::uint32_t>(v >> 32); };
    const Block out =
        philox4x32_10(Block{{low(counter), high(counter), low(stream), high(stream)}}, low(seed), high(seed));
    return (std::uint64_t{out.word[1]} << 32) | out.word[0];
}

double random_unit(std::uint64_t seed, std::uint64_t stream, std::uint64_t counter) {
    return static_cast<double>(random_bits(seed, stream, counter) >> 11) * 0x1.0p-53;
}

}  // namespace camrig

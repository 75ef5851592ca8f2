#include "proto/transfer/sha256.h"

#include <gtest/gtest.h>

namespace cwm {
namespace {

// FIPS 180-2, appendix B.1, and the hash of the empty message.
TEST(Sha256, GivesThePublishedDigests) {
  EXPECT_EQ(Sha256Hex("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(Sha256Hex(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
}

TEST(Sha256, DoesNotDependOnHowTheBytesAreCut) {
  const std::string bytes(1000, 'x');
  for (const std::size_t cut : {0U, 1U, 63U, 64U, 65U, 999U, 1000U}) {
    Sha256 sha;
    sha.Add(bytes.data(), cut);
    sha.Add(bytes.data() + cut, bytes.size() - cut);
    EXPECT_EQ(sha.Hex(), Sha256Hex(bytes)) << "cut at " << cut;
  }
}

}  // namespace
}  // namespace cwm

#include "server/core/encoded_meshes.h"

#include <gtest/gtest.h>

namespace cwm::server {
namespace {

std::shared_ptr<const EncodedMesh> Bytes(std::size_t count, char fill = 'x') {
  return std::make_shared<const EncodedMesh>(
      EncodedMesh{.bytes = std::string(count, fill), .hash = {}});
}

EncodedMeshCache::Source Living() { return std::make_shared<const int>(0); }

TEST(EncodedMeshCache, GiveBackWhatWasKeptForTheSameSourceAlone) {
  EncodedMeshCache encoded(100);
  const auto one = Living(), other = Living();
  EXPECT_EQ(encoded.Find(one), nullptr);
  const auto bytes = Bytes(10);
  encoded.Keep(one, bytes);
  EXPECT_EQ(encoded.Find(one), bytes);
  EXPECT_EQ(encoded.Find(other), nullptr);
}

TEST(EncodedMeshCache, LetGoOfWhatWasUsedLongestAgo) {
  EncodedMeshCache encoded(25);
  const auto a = Living(), b = Living(), c = Living();
  encoded.Keep(a, Bytes(10));
  encoded.Keep(b, Bytes(10));
  ASSERT_NE(encoded.Find(a), nullptr);  // now b is the oldest
  encoded.Keep(c, Bytes(10));
  EXPECT_EQ(encoded.Find(b), nullptr);
  EXPECT_NE(encoded.Find(a), nullptr);
  EXPECT_NE(encoded.Find(c), nullptr);
  EXPECT_EQ(encoded.held_bytes(), 20);
}

TEST(EncodedMeshCache, KeepOneThatIsLargerThanTheLimitUntilTheNext) {
  EncodedMeshCache encoded(25);
  const auto large = Living(), small = Living();
  encoded.Keep(large, Bytes(1000));
  EXPECT_NE(encoded.Find(large), nullptr) << "its ranges are read one after the other";
  encoded.Keep(small, Bytes(10));
  EXPECT_EQ(encoded.Find(large), nullptr);
  EXPECT_EQ(encoded.held_bytes(), 10);
}

TEST(EncodedMeshCache, KeepNothingOfTheDead) {
  EncodedMeshCache encoded(1000);
  auto mortal = Living();
  encoded.Keep(mortal, Bytes(500));
  const void* const address = mortal.get();
  mortal = nullptr;
  // A later source at the same address is a different one.
  const EncodedMeshCache::Source reborn(std::shared_ptr<void>(), address);
  EXPECT_EQ(encoded.Find(reborn), nullptr);
  encoded.Keep(Living(), Bytes(10));
  EXPECT_EQ(encoded.held_bytes(), 10);
}

TEST(EncodedMeshCache, CountASourceThatWasEncodedTwiceOnce) {
  EncodedMeshCache encoded(1000);
  const auto source = Living();
  encoded.Keep(source, Bytes(10, 'a'));
  encoded.Keep(source, Bytes(20, 'b'));
  EXPECT_EQ(encoded.Find(source)->bytes, std::string(20, 'b'));
  EXPECT_EQ(encoded.held_bytes(), 20);
  EXPECT_EQ(encoded.made(), 2);
}

}  // namespace
}  // namespace cwm::server

#include "perception/scene/join_pieces.h"

#include <numeric>

namespace cwm::perception {

std::vector<std::int32_t> JoinPieces(const SurfaceGraph&, const Pieces& pieces, const SightMap&) {
  std::vector<std::int32_t> object_of_piece(static_cast<std::size_t>(pieces.piece_count));
  std::iota(object_of_piece.begin(), object_of_piece.end(), 0);
  return object_of_piece;
}

}  // namespace cwm::perception

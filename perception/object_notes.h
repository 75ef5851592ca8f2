// Warnings about single objects, one for each kind.
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace cwm::perception {

// A remark about the object of that number, which counts from 1 as labels and names do; 0 stands
// for an object that was replaced since.
using ObjectNote = std::pair<std::size_t, std::string>;

// Returns a warning for each kind of remark, in the order of the first ones: "object 3: ...", or
// "objects 1, 4 and 9: ..."; of more than eight, the first eight and the number of the others.
std::vector<std::string> NotesByKind(const std::vector<ObjectNote>& notes);

}  // namespace cwm::perception

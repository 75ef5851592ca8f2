// Warnings of many things at a time.
#pragma once

#include <map>
#include <string>
#include <vector>

namespace cwm::server {

// Each note with the things that it is about: said once, of the first few by name.
class Notes {
 public:
  // Things come one after the other: one that is named again at once is counted once.
  void Add(const std::string& note, const std::string& thing);
  // "a, b and 4 more: what became of them", in the order of the notes.
  void AppendTo(std::vector<std::string>& warnings) const;

 private:
  std::map<std::string, std::vector<std::string>> things_;
};

}  // namespace cwm::server

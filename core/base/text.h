// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace panoptes {

/// The words in their order with `between` between them.
std::string joined(const std::vector<std::string>& words, std::string_view between = ", ");

/// `1 picture`, `2 pictures`
std::string counted(std::size_t count, std::string_view thing);

/// Between double quotes, as yaml and JSON read it back.
std::string in_quotes(const std::string& text);

/// As the text of an XML element, or of an attribute between double quotes, reads it back.
std::string xml_text(std::string_view text);

/// The order in which a person counts: `2.jpg` before `10.jpg`.
bool natural_less(std::string_view a, std::string_view b);

}  // namespace panoptes

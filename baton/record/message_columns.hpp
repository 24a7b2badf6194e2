/// Messages of a recording as rows of tables.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "baton/mcap/format.hpp"

namespace baton {

/// Name and value, as text: "position_left_knee", "0.25". What is no finite number is "nan".
using Column = std::pair<std::string, std::string>;

/// The members of a message in order, down to numbers and words; none for a message of a kind that is not known here.
/// Members of members are named by both, joined by "_", those of arrays by their number, from 0.
/// @param schema of the channel; null: none
/// @throws mcap::Malformed the message is not what its channel says
[[nodiscard]] std::vector<Column> columns_of(const mcap::Channel& channel, const mcap::Schema* schema,
                                             std::string_view message);

}  // namespace baton

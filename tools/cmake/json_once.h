// SPDX-License-Identifier: Apache-2.0
// nlohmann/json with its parser and writer compiled once, in json_once.cpp. That saves about half the compile time of a file that uses
// them. The precompiled header of targets marked JSON contains this file (DoppelTargets.cmake); sources still include <nlohmann/json.hpp>.
#pragma once

#include <nlohmann/json.hpp>

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#ifndef DPL_JSON_TEMPLATE
#define DPL_JSON_TEMPLATE extern template
#endif

NLOHMANN_JSON_NAMESPACE_BEGIN
namespace detail {
// The inputs that sources of this project parse from.
using DplFromConstBytes = decltype(input_adapter(std::vector<std::uint8_t>().cbegin(), std::vector<std::uint8_t>().cend()));
using DplFromBytes = decltype(input_adapter(std::vector<std::uint8_t>().begin(), std::vector<std::uint8_t>().end()));
using DplFromString = decltype(input_adapter(std::declval<const std::string&>()));
using DplFromView = decltype(input_adapter(std::declval<const std::string_view&>()));

DPL_JSON_TEMPLATE class lexer<json, DplFromConstBytes>;
DPL_JSON_TEMPLATE class lexer<json, DplFromBytes>;
DPL_JSON_TEMPLATE class lexer<json, DplFromString>;
DPL_JSON_TEMPLATE class lexer<json, DplFromView>;
DPL_JSON_TEMPLATE class parser<json, DplFromConstBytes>;
DPL_JSON_TEMPLATE class parser<json, DplFromBytes>;
DPL_JSON_TEMPLATE class parser<json, DplFromString>;
DPL_JSON_TEMPLATE class parser<json, DplFromView>;
DPL_JSON_TEMPLATE class json_sax_dom_parser<json>;
DPL_JSON_TEMPLATE class json_sax_dom_callback_parser<json>;
DPL_JSON_TEMPLATE class serializer<json>;
DPL_JSON_TEMPLATE class serializer<ordered_json>;
}  // namespace detail
DPL_JSON_TEMPLATE json::basic_json(const json&);
DPL_JSON_TEMPLATE json::basic_json(initializer_list_t, bool, detail::value_t);
DPL_JSON_TEMPLATE json::string_t json::dump(int, char, bool, detail::error_handler_t) const;
DPL_JSON_TEMPLATE ordered_json::basic_json(const ordered_json&);
DPL_JSON_TEMPLATE ordered_json::basic_json(initializer_list_t, bool, detail::value_t);
DPL_JSON_TEMPLATE ordered_json::string_t ordered_json::dump(int, char, bool, detail::error_handler_t) const;
NLOHMANN_JSON_NAMESPACE_END

#pragma once

#include <optional>
#include <span>

#include "fuzz/failure.hpp"
#include "fuzz/model.hpp"
#include "pierce/contact.hpp"

namespace pierce::fuzz {

/// What docs/contacts.md says of every contact, whatever the meshes; the first thing that does not
/// hold.
std::optional<Failure> broken_invariant(const Model& model, std::span<const Contact> contacts);

/// A contact in words.
std::string to_text(const Contact& contact);

}  // namespace pierce::fuzz

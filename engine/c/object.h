// What stands behind the C interface's pointers, and the border that no exception crosses.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <new>
#include <stdexcept>
#include <string>

#include "handhold/handhold.h"
#include "handhold/localizer.h"

namespace handhold::c {

/// First member of every object: callers from other languages hold untyped pointers and mix them up.
enum class Kind : std::uint64_t {
  kDestroyed = 0,
  kOptions = 0x736e6f6974706f68,  // letters rather than small numbers, which stand anywhere
  kLocalizer = 0x7a696c61636f6c68,
};

/// Of a fixed size, because a message about missing memory must need none.
struct Message {
  char text[1024] = "";

  void set(const char* message) noexcept {
    std::size_t i = 0;
    // One line, whatever text of the caller's it quotes.
    for (; message[i] && i + 1 < sizeof text; ++i) {
      text[i] = static_cast<unsigned char>(message[i]) < ' ' ? ' ' : message[i];
    }
    text[i] = '\0';
  }
};

/// message: NULL where no object is there to carry one.
inline handhold_code fail(Message* message, handhold_code code, const char* text) noexcept {
  if (message) message->set(text);
  return code;
}
inline handhold_code fail(Message* message, handhold_code code) noexcept {
  return fail(message, code, handhold_code_text(code));
}

/// Runs action() and turns what it throws into a code and a message. invalid: the code for std::invalid_argument, which
/// is what the library throws for a wrong cloud.
template <class Action>
handhold_code guarded(Message* message, handhold_code invalid, Action&& action) noexcept {
  if (message) message->set("");
  try {
    action();
    return HANDHOLD_OK;
  } catch (const OptionError& error) {
    return fail(message, HANDHOLD_BAD_OPTION, error.what());
  } catch (const std::invalid_argument& error) {
    return fail(message, invalid, error.what());
  } catch (const std::bad_alloc&) {
    return fail(message, HANDHOLD_NO_MEMORY);
  } catch (const std::exception& error) {
    return fail(message, HANDHOLD_FAILED, error.what());
  } catch (...) {
    return fail(message, HANDHOLD_FAILED);
  }
}

/// Whether `object` may be used as one of its type. A destroyed one is noticed by luck only, a wrong one always.
template <class Object>
handhold_code check(const Object* object) noexcept {
  if (!object) return HANDHOLD_NULL_ARGUMENT;
  return object->kind == Object::kKind ? HANDHOLD_OK : HANDHOLD_BAD_OBJECT;
}

template <class Object>
void destroy(Object* object) noexcept {
  if (check(object) != HANDHOLD_OK) return;
  object->kind = Kind::kDestroyed;
  // The compiler may otherwise leave out a store to memory that is freed next.
  std::atomic_signal_fence(std::memory_order_seq_cst);
  delete object;
}

}  // namespace handhold::c

struct handhold_options {
  static constexpr handhold::c::Kind kKind = handhold::c::Kind::kOptions;
  handhold::c::Kind kind = kKind;
  handhold::Options options;
  std::string text;  ///< what handhold_get returned last
  handhold::c::Message message;
};

struct handhold_localizer {
  explicit handhold_localizer(const handhold::Options& options) : localizer(options) {}

  static constexpr handhold::c::Kind kKind = handhold::c::Kind::kLocalizer;
  handhold::c::Kind kind = kKind;
  handhold::Localizer localizer;
  handhold::Result result;
  bool has_result = false;
  /// Calls that read the result just now; -1: handhold_localize makes it.
  mutable std::atomic<int> users{0};
  handhold::c::Message message;
};

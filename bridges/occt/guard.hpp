// SPDX-License-Identifier: Apache-2.0
// Around every call of Open CASCADE: silence, and exceptions that become statuses.
#ifndef BRIDGES_OCCT_GUARD_HPP
#define BRIDGES_OCCT_GUARD_HPP

#include <new>

#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <Standard_Failure.hxx>
#include <Standard_OutOfMemory.hxx>

#include <knurl/base.h>
extern "C" {
#include "kernel/context.h"
}

namespace kn_occt
{

// OCCT reports to the terminal; the library is silent. What printers were there come back at the end.
class silence
{
  public:
    silence() : printers(Message::DefaultMessenger()->ChangePrinters())
    {
        Message::DefaultMessenger()->ChangePrinters().Clear();
    }
    silence(const silence &) = delete;
    silence &operator=(const silence &) = delete;
    ~silence()
    {
        Message::DefaultMessenger()->ChangePrinters() = printers;
    }

  private:
    Message_SequenceOfPrinters printers;
};

// What a function of knurl answered, thrown through C++: its message is in the context already.
struct failed {
    kn_status status;
};
inline void check(kn_status status)
{
    if (status != KN_OK) throw failed{status};
}

// Runs f; what it throws becomes a status. what: a file, in the message.
template <class F> kn_status guarded(kn_ctx *ctx, const char *what, F f)
{
    try {
        silence quiet;
        return f();
    } catch (const failed &failure) {
        return failure.status;
    } catch (const std::bad_alloc &) {
        return kn_fail(ctx, KN_ENOMEM, "%s: out of memory", what);
    } catch (const Standard_OutOfMemory &) {
        return kn_fail(ctx, KN_ENOMEM, "%s: out of memory", what);
    } catch (const Standard_Failure &failure) {
        const char *text = failure.GetMessageString();
        return kn_fail(ctx, KN_EUNDECIDED, "%s: OCCT: %s", what,
                       text && *text ? text : failure.DynamicType()->Name());
    } catch (...) {
        return kn_fail(ctx, KN_EUNDECIDED, "%s: OCCT threw", what);
    }
}

} // namespace kn_occt

#endif

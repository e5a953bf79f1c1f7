// What a desktop does to a window: drops files on it by XDND, asks it to close.
//
//   x_client drop WINDOW FILE...
//   x_client close WINDOW
// SPDX-License-Identifier: MPL-2.0
//
// source  freedesktop.org, Drag-and-Drop Protocol for the X Window System, version 5
#include <X11/Xatom.h>
#include <X11/Xlib.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string>

namespace {

class Client {
public:
    explicit Client(Window target) : target_(target) {
        if (!display_) {
            std::fprintf(stderr, "x_client: no display\n");
            std::exit(1);
        }
        source_ = XCreateSimpleWindow(display_, DefaultRootWindow(display_), 0, 0, 1, 1, 0, 0, 0);
    }
    ~Client() { XCloseDisplay(display_); }

    void close() {
        send("WM_PROTOCOLS", {static_cast<long>(atom("WM_DELETE_WINDOW")), CurrentTime, 0, 0, 0});
        XSync(display_, False);
    }

    /// returns  whether the window took them
    bool drop(const std::string& uris) {
        XSetSelectionOwner(display_, atom("XdndSelection"), source_, CurrentTime);
        const long source = static_cast<long>(source_);
        send("XdndEnter", {source, 5L << 24, static_cast<long>(atom("text/uri-list")), 0, 0});
        send("XdndPosition", {source, 0, (300L << 16) | 300, CurrentTime,
                              static_cast<long>(atom("XdndActionCopy"))});
        for (;;) {
            XEvent event;
            XNextEvent(display_, &event);
            if (event.type == ClientMessage) {
                const XClientMessageEvent& message = event.xclient;
                if (message.message_type == atom("XdndStatus")) {
                    if ((message.data.l[1] & 1) == 0) return false;
                    send("XdndDrop", {source, 0, CurrentTime, 0, 0});
                } else if (message.message_type == atom("XdndFinished")) {
                    return (message.data.l[1] & 1) != 0;
                }
            } else if (event.type == SelectionRequest) {
                give(event.xselectionrequest, uris);
            }
        }
    }

private:
    struct Data {
        long l[5];
    };
    Atom atom(const char* name) { return XInternAtom(display_, name, False); }

    void send(const char* type, const Data& data) {
        XEvent event{};
        event.xclient.type = ClientMessage;
        event.xclient.display = display_;
        event.xclient.window = target_;
        event.xclient.message_type = atom(type);
        event.xclient.format = 32;
        std::memcpy(event.xclient.data.l, data.l, sizeof data.l);
        XSendEvent(display_, target_, False, NoEventMask, &event);
        XFlush(display_);
    }

    void give(const XSelectionRequestEvent& request, const std::string& text) {
        XChangeProperty(display_, request.requestor, request.property, request.target, 8,
                        PropModeReplace, reinterpret_cast<const unsigned char*>(text.data()),
                        static_cast<int>(text.size()));
        XEvent event{};
        event.xselection.type = SelectionNotify;
        event.xselection.requestor = request.requestor;
        event.xselection.selection = request.selection;
        event.xselection.target = request.target;
        event.xselection.property = request.property;
        event.xselection.time = request.time;
        XSendEvent(display_, request.requestor, False, NoEventMask, &event);
        XFlush(display_);
    }

    Display* display_ = XOpenDisplay(nullptr);
    Window target_;
    Window source_ = 0;
};

} // namespace

int main(int argc, char** argv) {
    if (argc < 3) return 2;
    Client client(std::strtoul(argv[2], nullptr, 0));
    if (std::string(argv[1]) == "close") {
        client.close();
        return 0;
    }
    std::string uris;
    for (int i = 3; i < argc; ++i)
        uris += "file://" + std::filesystem::absolute(argv[i]).string() + "\r\n";
    return client.drop(uris) ? 0 : 1;
}

# SPDX-License-Identifier: Apache-2.0
"""Sends to a window what a file manager and a window manager would: dropped files (XDND) and the wish to close. Uses libX11 through ctypes."""
import ctypes
import select

CURRENT_TIME, NONE, PROP_REPLACE = 0, 0, 0
SELECTION_REQUEST, SELECTION_NOTIFY, CLIENT_MESSAGE = 30, 31, 33


class ClientMessage(ctypes.Structure):
    _fields_ = [("type", ctypes.c_int), ("serial", ctypes.c_ulong), ("send_event", ctypes.c_int), ("display", ctypes.c_void_p),
                ("window", ctypes.c_ulong), ("message_type", ctypes.c_ulong), ("format", ctypes.c_int), ("data", ctypes.c_long * 5)]


class SelectionRequest(ctypes.Structure):
    _fields_ = [("type", ctypes.c_int), ("serial", ctypes.c_ulong), ("send_event", ctypes.c_int), ("display", ctypes.c_void_p),
                ("owner", ctypes.c_ulong), ("requestor", ctypes.c_ulong), ("selection", ctypes.c_ulong), ("target", ctypes.c_ulong),
                ("property", ctypes.c_ulong), ("time", ctypes.c_ulong)]


class SelectionNotify(ctypes.Structure):
    _fields_ = [("type", ctypes.c_int), ("serial", ctypes.c_ulong), ("send_event", ctypes.c_int), ("display", ctypes.c_void_p),
                ("requestor", ctypes.c_ulong), ("selection", ctypes.c_ulong), ("target", ctypes.c_ulong), ("property", ctypes.c_ulong),
                ("time", ctypes.c_ulong)]


class Event(ctypes.Union):
    _fields_ = [("type", ctypes.c_int), ("message", ClientMessage), ("request", SelectionRequest), ("notify", SelectionNotify),
                ("pad", ctypes.c_long * 24)]


class Sender:
    """A connection to the display `name`, such as ":99"."""

    def __init__(self, name):
        self.x = ctypes.CDLL("libX11.so.6")
        self.x.XOpenDisplay.restype = ctypes.c_void_p
        for function in ("XInternAtom", "XCreateSimpleWindow", "XDefaultRootWindow"):
            getattr(self.x, function).restype = ctypes.c_ulong
        self.display = ctypes.c_void_p(self.x.XOpenDisplay(name.encode()))
        if not self.display:
            raise RuntimeError(f"display {name} cannot be opened")
        root = self.x.XDefaultRootWindow(self.display)
        self.source = self.x.XCreateSimpleWindow(self.display, ctypes.c_ulong(root), 0, 0, 1, 1, 0, ctypes.c_ulong(0), ctypes.c_ulong(0))

    def atom(self, name):
        return self.x.XInternAtom(self.display, name.encode(), 0)

    def send(self, window, event):
        self.x.XSendEvent(self.display, ctypes.c_ulong(window), 0, ctypes.c_long(0), ctypes.byref(event))
        self.x.XFlush(self.display)

    def message(self, window, kind, *data):
        event = Event()
        event.message.type, event.message.window, event.message.format = CLIENT_MESSAGE, window, 32
        event.message.message_type = self.atom(kind)
        for i, value in enumerate(data):
            event.message.data[i] = value
        self.send(window, event)

    def close(self, window):
        self.message(window, "WM_PROTOCOLS", self.atom("WM_DELETE_WINDOW"), CURRENT_TIME)

    def drop(self, window, paths, timeout_s=600):
        """Drops the files and returns when the window has taken them."""
        selection, text = self.atom("XdndSelection"), self.atom("text/uri-list")
        self.x.XSetSelectionOwner(self.display, ctypes.c_ulong(selection), ctypes.c_ulong(self.source), ctypes.c_ulong(CURRENT_TIME))
        self.message(window, "XdndEnter", self.source, 5 << 24, text, NONE, NONE)
        self.message(window, "XdndPosition", self.source, 0, (50 << 16) | 50, CURRENT_TIME, self.atom("XdndActionCopy"))
        uris = "".join(f"file://{path}\r\n" for path in paths).encode()
        connection = self.x.XConnectionNumber(self.display)
        while self.x.XPending(self.display) or select.select([connection], [], [], timeout_s)[0]:
            if not self.x.XPending(self.display):
                continue  # part of an event
            event = Event()
            self.x.XNextEvent(self.display, ctypes.byref(event))
            if event.type == CLIENT_MESSAGE and event.message.message_type == self.atom("XdndStatus"):
                if not event.message.data[1] & 1:
                    raise RuntimeError("the window does not take files")
                self.message(window, "XdndDrop", self.source, 0, CURRENT_TIME, NONE, NONE)
            elif event.type == CLIENT_MESSAGE and event.message.message_type == self.atom("XdndFinished"):
                return
            elif event.type == SELECTION_REQUEST:
                self.answer(event.request, uris)
        raise RuntimeError("the window has not taken the dropped files")

    def answer(self, request, uris):
        self.x.XChangeProperty(self.display, ctypes.c_ulong(request.requestor), ctypes.c_ulong(request.property),
                               ctypes.c_ulong(request.target), 8, PROP_REPLACE, uris, len(uris))
        event = Event()
        event.notify.type, event.notify.requestor, event.notify.selection = SELECTION_NOTIFY, request.requestor, request.selection
        event.notify.target, event.notify.property, event.notify.time = request.target, request.property, request.time
        self.send(request.requestor, event)

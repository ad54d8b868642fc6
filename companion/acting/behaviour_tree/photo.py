"""The leaf that takes a photo: done when the camera has stored it, and taken once each time.

A photo is due once for its action at each position of the word. After a failed try, a pause,
another plan, or a crash of the process, the leaf returns to the same photo; the camera's counter
then tells whether it was taken. It is reported once.
"""

from __future__ import annotations

from py_trees.common import Status

from companion.acting.behaviour_tree.kept_intention import kept
from companion.acting.behaviour_tree.leaf import Leaf
from companion.acting.flight import Flight
from companion.acting.journal import PhotoReported
from companion.flight_events.skills import PhotoTaken
from companion.flight_events.tree import LeafType
from companion.mission.facts import AT, HERE
from companion.mission.payload_steps import Photo
from companion.outcomes import Failed, Progress
from companion.vehicle.ports.cameras import IntendedShot, PhotoMade, ShotOwner, ShotReady


class TakePhoto(Leaf):
    """Takes a photo while the vehicle holds.

    The journal has the intention on the disk before the camera is asked.

    Args:
        flight: what it acts on.
        photo: the camera to use.
        timeout_s: time for all of it; None for the default.
    """

    does = LeafType.PHOTO

    def __init__(self, flight: Flight, photo: Photo, timeout_s: float | None) -> None:
        super().__init__(flight, f"photo {photo.camera}")
        self._photo = photo
        self._timeout_s = timeout_s
        self._ticket: int | None = None
        self._intended_s: float | None = None

    def initialise(self) -> None:
        """Asks the camera for its number of photos."""
        cameras, running = self._flight.vehicle.cameras, self._flight.task.running
        may_repeat = running is not None and running.is_repeatable
        self._ticket = cameras.prepare(
            self._photo.component, self._owner, self._timeout_s, may_repeat=may_repeat
        )
        self._intended_s = None

    def update(self) -> Status:
        """SUCCESS if the photo has been taken."""
        flight, ticket = self._flight, self._ticket
        assert ticket is not None
        flight.guidance.hold()
        match flight.vehicle.cameras.outcome(ticket):
            case ShotReady() as ready:
                return self._shoot(ready, ticket)
            case PhotoMade() as made:
                self._tell(made)
                return Status.SUCCESS
            case Failed(reason):
                return self.fail(reason)
        return Status.RUNNING

    def terminate(self, new_status: Status) -> None:
        """Stops waiting for it."""
        if new_status is not Status.RUNNING and self._ticket is not None:
            self._flight.vehicle.cameras.forget(self._ticket)
            self._ticket = None

    @property
    def _owner(self) -> ShotOwner:
        owner = self.owner()
        return (owner.action, owner.position, owner.nth)

    def _shoot(self, ready: ShotReady, ticket: int) -> Status:
        """Asks for the photo, after the intention was written down."""
        flight = self._flight
        if self._intended_s is None:
            self._intended_s = flight.now_s
            intended = IntendedShot(
                self._photo.component,
                *self._owner,
                sequence=ready.sequence,
                image_count=ready.image_count,
            )
            flight.note(intended)
        is_kept = kept(flight, self._intended_s)
        if is_kept is not Progress.DONE:
            return self.status_of(is_kept)
        flight.vehicle.cameras.shoot(ticket)
        return Status.RUNNING

    def _tell(self, made: PhotoMade) -> None:
        flight, state = self._flight, self._flight.vehicle.state
        if state is not None and self._owner not in flight.photos_reported:
            running = flight.task.running
            is_flying = running is not None and running.destination is not None
            places = [fact.arguments[0] for fact in flight.task.facts if fact.predicate == AT]
            north_m, east_m, _ = here = state.motion.position
            where = f"{east_m:.1f} m east, {north_m:.1f} m north"
            place = where if is_flying or HERE in places or not places else min(places)
            flight.report(
                PhotoTaken(made.number, self._photo.camera, place, made.image_index, here)
            )
            flight.photos_reported.add(self._owner)
            flight.note(PhotoReported(*self._owner))
